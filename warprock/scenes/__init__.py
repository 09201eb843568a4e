"""Moving pictures of lanes, and viewers of them."""
