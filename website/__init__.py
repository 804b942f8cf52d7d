"""The site: docs/ and what is made from the code, as pages with search. `make site` builds it by MkDocs, whose hooks are in hooks.py."""
