"""Why do a stem and its model disagree, by its measured force and position alone?"""
