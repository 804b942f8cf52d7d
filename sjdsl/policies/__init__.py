"""Scripted policies of games, `policy NAME { … }`, compiled and interpreted."""
