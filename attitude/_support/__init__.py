"""What every subject needs: checks of input, arrays, pairs of doubles, blocks, text of numbers."""
