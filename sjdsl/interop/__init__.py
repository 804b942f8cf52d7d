"""Adapters: compiled games for other libraries, one file for each library, each an optional extra of the package."""
