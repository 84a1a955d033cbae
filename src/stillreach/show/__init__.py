"""Pictures of runs and arms (extra ``plot``)."""
