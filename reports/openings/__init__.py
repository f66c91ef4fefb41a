"""What each page opens with, one module a page; ``reports.opening`` says what an opening is."""
