sj 1
game pond "A sign that takes the next one with it" {
  kind wall "\"
}
