"""Are the draws what they should be: every kind of draw against its distribution, and the draws of different rules against each other."""
