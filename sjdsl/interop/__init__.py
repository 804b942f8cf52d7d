"""Adapters: compiled games for other libraries.

Each library has a file here and an optional extra of the package.
"""
