"""What trajectories and period maps show; knows arrays, no physics."""
