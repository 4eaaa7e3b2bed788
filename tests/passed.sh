# For run.sh and cross.sh to source: a run that passed leaves the hash of the tree that it tested in build/NAME/passed.

# The committed tree's hash; nothing while something is not committed, or outside a clone.
tree_to_test() {
  [[ -z $(git status --porcelain 2>&1) ]] || return 0
  git rev-parse 'HEAD^{tree}' 2>/dev/null || true
}

# forget_passed NAME: before a run begins.
forget_passed() { rm -f "build/$1/passed"; }

# leave_passed NAME TREE: once all of a run has passed. TREE is what tree_to_test gave before it began.
leave_passed() {
  [[ -n $2 && $2 == "$(tree_to_test)" ]] || return 0
  echo "$2" >"build/$1/passed"
}
