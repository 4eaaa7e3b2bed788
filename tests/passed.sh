# Sourced by run.sh and cross.sh: a run that passes writes the hash of the tested tree to build/NAME/passed.

# Prints the committed tree's hash; nothing if there are uncommitted changes, or outside a clone.
tree_to_test() {
  [[ -z $(git status --porcelain 2>&1) ]] || return 0
  git rev-parse 'HEAD^{tree}' 2>/dev/null || true
}

# forget_passed NAME: called before a run begins.
forget_passed() { rm -f "build/$1/passed"; }

# leave_passed NAME TREE: called after a complete run has passed. TREE is the result of tree_to_test before the run.
leave_passed() {
  [[ -n $2 && $2 == "$(tree_to_test)" ]] || return 0
  echo "$2" >"build/$1/passed"
}
