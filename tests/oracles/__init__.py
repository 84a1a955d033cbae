"""What the compiled core is judged by: other routes to the same answers, in NumPy and SciPy only.

Nothing here imports `stillreach`, and nothing here is fast or clever.
"""
