"""Compiled games in the ecosystems people already use: one small file an ecosystem, each an optional extra of the package."""
