"""`python -m stillreach`: the same as the command `stillreach`."""

from stillreach.cli import main

if __name__ == "__main__":
    main()
