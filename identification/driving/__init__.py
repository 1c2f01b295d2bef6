"""Which current drove the valve: before a row or after it, between the rows, or below the noise of a meter?"""
