"""Which current drove the valve, where a record does not have it: between its rows, or below the noise of a meter?"""
