"""Kinds of values that arguments take. The name of an alias is the placeholder of its option."""

Column = str
"""Name of a column: the option has COLUMN."""
Acceleration = str
Age = str
Angle = str
Density = str
Frequency = str
Length = str
Mass = str
Quantity = str
Time = str
"""Texts with a unit."""
Share = float
"""A share, from 0 to 1."""
