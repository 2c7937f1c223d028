"""Reports to send on: what a finished run or a league was and what came of it, in one file for a browser."""
