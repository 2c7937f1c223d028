"""Who runs the points of a sweep, and how work is handed to them."""
