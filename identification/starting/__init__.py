"""Where does the search for one more effect begin? Hints in the record, starts, and the problem it is put in."""
