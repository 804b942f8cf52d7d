"""Adapters: compiled games for other libraries, a file and an optional extra of the package for
each library."""
