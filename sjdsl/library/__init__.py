"""Games by name: bundled ones and those of files, read once, with their parameters, and the environment made of one."""
