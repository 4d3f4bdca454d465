# SPDX-License-Identifier: Apache-2.0
# The help of a program or command, as CLI11 writes it, in roff. title: the command's name; empty for the program.

function roff(text) {
  gsub(/\\/, "\\e", text)
  gsub(/-/, "\\-", text)
  if (text ~ /^['.]/) text = "\\\\&" text
  return text
}

# "--points TEXT Excludes: --input" -> its name bold, the rest as it is.
function print_entry(head, help,    name, rest) {
  name = head
  sub(/ .*/, "", name)
  rest = substr(head, length(name) + 1)
  sub(/,/, ", ", name)
  # Which options go together: after the words that say what it is.
  if (match(rest, / (Needs|Excludes): .*/)) {
    help = help (help ~ /[.;]$/ ? "" : ";") tolower(substr(rest, RSTART, RLENGTH))
    rest = substr(rest, 1, RSTART - 1)
  }
  sub(/:[A-Z]+ in /, " in ", rest)
  sub(/:FILE$/, "", rest)
  print ".TP"
  printf ".B %s\n", roff(name rest)
  print roff(help)
}

function flush() {
  if (head != "") print_entry(head, help)
  head = help = ""
}

BEGIN { column = 30 }

NR == 1 && title != "" {
  printf ".SS %s\n%s\n", roff(title), roff(toupper(substr($0, 1, 1)) substr($0, 2) ".")
  next
}
/^[A-Z].*:$/ { flush(); part = $0; next }
part == "" { next }                              # the description and the usage line
part == "Subcommands:" && title == "" { next }   # each has its own paragraph
/^  [^ ]/ {
  flush()
  line = substr($0, 3)
  # Two blanks part name and help where the name is short, the column where it is not.
  if (length($0) > column && substr($0, column, 1) == " ") {
    head = substr($0, 3, column - 3)
    help = substr($0, column + 1)
    sub(/ +$/, "", head)
    if (substr($0, column + 1, 1) == " " || head ~ /^$/) { head = line; help = "" }
  } else {
    head = line
  }
  if (head ~ /^-h,--help/) head = help = ""
  next
}
/^ +[^ ]/ { sub(/^ +/, ""); if (head != "") help = help (help == "" ? "" : " ") $0 }
END { flush() }
