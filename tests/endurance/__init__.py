"""Let laws drill for a day, under weights and formations that change at random: `python -m tests.endurance`.

`make endurance` takes 24 h of each law; `tests/laws/test_ten_minutes.py` ten minutes of it.
"""
