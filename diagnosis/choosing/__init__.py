"""Which effects are tried, in which order, and when is it enough? From every one alone to several together."""
