"""The equations of motion in the languages of other tools."""
