"""The scripts that make the reference need heyoka and AUTO; they hold no tests."""

collect_ignore = ["make_reference.py", "runner.py", "shooting.py", "systems.py"]
