"""The server behind ``remanent explore``: a page, its data, and jobs in processes of their own."""
