#!/usr/bin/env bash
# Completion of `sof` in bash: subcommands, options and effects as sof itself tells them; files elsewhere.
_sof() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} told
  COMPREPLY=()
  case $before in
    --effects | --given | --verify-detection-limits | --extend)
      told=$(sof effects --json - 2>/dev/null | sed -n 's/^ *"id": "\([a-z0-9_]*\)".*/\1/p')
      local prefix=${word%"${word##*,}"}
      mapfile -t COMPREPLY < <(compgen -P "$prefix" -W "$told" -- "${word##*,}")
      return
      ;;
    --mode)
      mapfile -t COMPREPLY < <(compgen -W "mixed current" -- "$word")
      return
      ;;
  esac
  if [ "$COMP_CWORD" = 1 ]; then
    told="$(sof --help 2>/dev/null | sed -n '/^Subcommands/,$ s/^  \([a-z-]*\) .*/\1/p') --help --version"
  elif [ "${word:0:1}" = - ]; then
    told=$(sof "${COMP_WORDS[1]}" --help 2>/dev/null | sed -n 's/^ *\(-h,\)\{0,1\}\(--[a-z0-9-]*\).*/\2/p')
  else
    compopt -o default 2>/dev/null
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$told" -- "$word")
}
complete -F _sof sof
