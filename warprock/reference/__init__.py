"""What the engines are held against: references that share no formula with them."""
