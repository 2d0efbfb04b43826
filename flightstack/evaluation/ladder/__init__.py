"""Named rungs beyond the paper's levels, and what each costs."""
