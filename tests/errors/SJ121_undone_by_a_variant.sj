# variants: rich
sj 1
game lake extends "base/pond.sj" {
  set growth = 0.2
  set meal = 2
  phase eat { each agent on shore where shore.fruit is ripe { set shore.fruit = none  give meal to all } }
  map { "..." }
  observe { window ahead 1 }
  drop gift
}
