"""How sure is the diagnosis: of each cause, of none, of an unknown one, and of what hides or looks the same?"""
