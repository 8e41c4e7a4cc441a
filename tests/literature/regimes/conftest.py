"""The scripts that make the cases need heyoka; they hold no tests."""

collect_ignore = ["families.py", "flows.py", "make_cases.py", "verdict.py"]
