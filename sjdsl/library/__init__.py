"""Games by name: bundled, of installed packages and of files, read once, with their parameters, and the environment made of one."""
