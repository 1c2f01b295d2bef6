"""In which stage, where along the travel and when does the gap arise, and what does it depend on?"""
