"""The claims, a module for each kind; importing this enters them into the list, in the order of the paper."""

from tests.verify.claim import CLAIMS
from tests.verify.claims import equations, figures, friction, proposition, stability, strategies

ORDER = [kind.__name__ for kind in (friction, equations, proposition, stability, figures, strategies)]
CLAIMS.sort(key=lambda claim: ORDER.index(claim.try_it.__module__))
