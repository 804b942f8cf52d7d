"""The release and where the project lives, alone in a file so that whoever prints them imports nothing else."""

__version__ = "0.1.0"
HOMEPAGE = "https://github.com/sjdsl/sjdsl"
