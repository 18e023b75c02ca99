"""docs/results.json: figures as commands print them, the pages made of them, and the gate that holds new figures against them."""
