"""The product held against laws, and the paper's claims held against the product.

``python -m tests.verify`` (``make verify``) judges all and prints a report. Each law is a function in `laws`, each
claim one in `claims`; pytest judges the same functions. A law holds if the error found is within what is allowed for a
reason, and the verdict on a claim follows from its trials.
"""
