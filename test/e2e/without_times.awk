# report.csv without the columns of times that were measured, whose headings end in _seconds.
BEGIN { FS = OFS = "," }
NR == 1 { for (i = 1; i <= NF; i++) if ($i !~ /_seconds$/) kept[++count] = i }
{
    line = $kept[1]
    for (i = 2; i <= count; i++) line = line OFS $kept[i]
    print line
}
