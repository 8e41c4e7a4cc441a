"""From symbols to straight-line code: equations of motion become a Field."""
