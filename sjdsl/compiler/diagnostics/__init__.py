"""What the compiler tells an author: places in a text, codes and messages, and how they are shown."""
