sj 1
game visitors "Public goods with policies that give or keep, and scenarios of them" {
  size  players    : count  = 3 in 1 .. 8
  param multiplier : reward = 2 in 0 .. 20
  param ranked     : reward = 0 in 0 .. 1
  episode 2

  kind floor "."
  map { "........" }

  agents players {
    acts stay, keep
    field deed : { give_one, keep_it } = give_one
  }

  phase start { each agent { send agent to floor } }
  schedule decide -> share
  phase decide { each agent { when agent chose keep { set agent.deed = keep_it } otherwise { set agent.deed = give_one } } }
  phase share {
    each agent { give multiplier * count(agent as other where other.deed is give_one) / players + ranked * agent.index to agent }
    each agent where agent.deed is give_one { give -1 to agent  tally given for agent }
  }

  observe { window ahead 0, behind 0, left 0, right 0 }
  metrics { event given }

  policy giver  "gives each step"  { when step >= 0 choose stay }
  policy keeper "keeps each step" { when step >= 0 choose keep }
  scenario visitor  "one among those who keep" { slots 1 focal  slots players - 1 policy keeper }
  scenario intruded "all but one, who keeps"   { slots 1 policy keeper  slots players - 1 focal }
  scenario three    "two and one who gives"    { slots 2 focal  slots 1 policy giver }
  scenario alone    "only focal agents"        { slots players focal }
}
