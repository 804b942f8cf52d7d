"""Scripted policies of games: what the rules of `policy NAME { … }` make an agent do, compiled and interpreted."""
