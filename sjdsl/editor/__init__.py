"""Answers to editors: functions from texts and positions to the Language Server Protocol."""
