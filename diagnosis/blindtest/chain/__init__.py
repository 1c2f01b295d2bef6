"""The plant's physics, one stage a file, integrated with small fixed steps.

Nothing here is shared with the toolkit that is judged with it. A signal is an array of shape
(periods, width): width 1 where the value is held through each sample period, else the number of fine
steps in a period.
"""
