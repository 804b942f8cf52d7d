"""`python -m sjdsl` is the command `sjdsl`."""

from sjdsl.cli import main

if __name__ == "__main__":
    main()
