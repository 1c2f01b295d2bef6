def write_page(path, content): path.write_text("x")
