"""The parts of a survey: what is surveyed, one chunk of it, where it is stored, who computes it."""
