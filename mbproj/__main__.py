"""`python -m mbproj`: the command line, where the script `mbproj` is not on the path."""

from mbproj.cli import main

if __name__ == "__main__":
    main()
