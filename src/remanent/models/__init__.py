"""Physics: actuators, materials, drives and the equations of motion they lead to."""
