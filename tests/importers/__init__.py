"""The FMUs of dist/ in tools that are not ours, compared with our master to the last bit."""
