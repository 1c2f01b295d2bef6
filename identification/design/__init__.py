"""Which current to send next: admissible inputs, what they would tell, and the one that tells most."""
