#!/usr/bin/env bash
# Completion of `sof` in bash. Subcommands, options and what an option takes are read from the parser's own help; files elsewhere.
_sof() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} prefix="" help takes="" told
  COMPREPLY=()
  if [ "$COMP_CWORD" = 1 ]; then
    told="$(sof --help 2>/dev/null | sed -n '/^Subcommands/,$ s/^  \([a-z-]*\) .*/\1/p') --help --version"
    mapfile -t COMPREPLY < <(compgen -W "$told" -- "$word")
    return
  fi
  help=$(sof "${COMP_WORDS[1]}" --help 2>/dev/null)
  if [[ $before =~ ^--[a-z0-9-]+$ ]]; then
    takes=$(sed -n "s/^ *$before \([A-Z][^ =]*\).*/\1/p" <<<"$help")
  elif [ "${word:0:1}" != - ]; then
    takes=$(sed -n 's/^  \(ID\) .*/\1/p' <<<"$help")
  fi
  case $takes in
    ID)
      # The document lists effects first, then mechanisms, which no option takes.
      told=$(sof effects --json - 2>/dev/null | sed -n '/^  "mechanisms"/q; s/^ *"id": "\([a-z0-9_]*\)".*/\1/p')
      prefix=${word%"${word##*,}"}
      # A help text may name an alternative to ids: "..., or none."
      if [ -z "$prefix" ] && sed -n "s/^ *$before //p" <<<"$help" | grep -q ', or none\.'; then told="$told none"; fi
      ;;
    *':{'*'}'*)
      told=${takes#*:\{}
      told=${told//[,\}]/ }
      ;;
    *)
      if [ -n "$takes" ] || [ "${word:0:1}" != - ]; then
        compopt -o default 2>/dev/null
        return
      fi
      told=$(sed -n 's/^ *\(-h,\)\{0,1\}\(--[a-z0-9-]*\).*/\2/p' <<<"$help")
      ;;
  esac
  mapfile -t COMPREPLY < <(compgen -P "$prefix" -W "$told" -- "${word#"$prefix"}")
}
complete -F _sof sof
