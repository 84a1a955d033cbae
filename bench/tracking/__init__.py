"""How well the default law tracks: beside the bare optimum and a box QP, on arms that nobody here made."""
