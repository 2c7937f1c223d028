"""Make the site of the documentation: pages of docs/, pages made from the product, and the driller's console."""
