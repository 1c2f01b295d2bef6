"""What do the paper's figures show, as its model really gives them?"""
