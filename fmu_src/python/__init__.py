"""The slaves of the python packaging: pythonfmu over the readable models."""
