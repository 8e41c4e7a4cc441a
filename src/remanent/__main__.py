"""``python -m remanent``, the same as the command ``remanent``."""

from remanent.cli.main import main

if __name__ == "__main__":
    main()
