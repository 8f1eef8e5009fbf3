"""The guide: pages in four kinds of folder, shown by `mbproj help`. A new page is a Markdown file."""
